"""The scripted operator: a control law that drives the arm after what it sees, in real time or in a batch."""
