"""The elastic half-space: all that the microcontact model and the boundary elements share."""
