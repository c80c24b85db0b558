"""Who sees and reads: the student policy `hv`, and the motor prior that it shares with the teachers."""
