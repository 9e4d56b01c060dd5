"""The microcontact model of one map: plan, summits, their laws."""
