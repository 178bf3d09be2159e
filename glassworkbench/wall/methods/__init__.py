"""The methods of hollowing, one file each; all take a mold and a wall and hand over a candidate."""
