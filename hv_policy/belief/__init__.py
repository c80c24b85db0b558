"""What the student believes about its task: measured in pictures, carried along by odometry, and decided from."""
