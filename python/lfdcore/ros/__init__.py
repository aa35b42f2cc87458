"""A ROS 2 robot as a chair: its topics are the senses and the commands of the drive loop (docs/on-your-robot.md)."""
