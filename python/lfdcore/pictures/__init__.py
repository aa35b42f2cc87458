"""Pictures: of courses, the local window, the stages of both methods, beliefs and collaborations, in one style."""
