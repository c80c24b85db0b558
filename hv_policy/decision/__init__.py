"""From what is known of a task to an intent: the network that the teachers and the student decide with."""
