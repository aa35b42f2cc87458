"""lfdcore study sequences: which task has the partner begun (Sec. 6.2.2)?"""
