"""The microcontact model against boundary elements: errors and run times."""
