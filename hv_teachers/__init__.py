"""Who knows the state: references, planner, rewards, teachers, and the recorder of what they do."""
