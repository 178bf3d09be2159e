"""What came out: the wall against what was asked, crossings, volumes, contents, pictures."""
