"""lfdcore study goals: where is the driver going, in a known map (Ch. 2; Tables 2.1-2.2)?"""
