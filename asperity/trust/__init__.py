"""How far an answer of the microcontact model can be trusted."""
