"""Small changes of a program, each a mistake that a programmer could have made: which of them do its tests notice?"""
