"""The methods of hollowing, one file each; every one is a `candidate.Method`."""
