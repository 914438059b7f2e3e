"""The programs of the controller: the task MAST, the library of the blocks, and RUN and STOP."""
