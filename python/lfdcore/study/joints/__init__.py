"""lfdcore study joints: primitives of joint angles beside those of gripper poses (Sec. 6.2.2)."""
