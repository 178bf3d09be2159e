"""What wall is asked: thickness as data and as text, and what it means at each point of a mold's outside."""
