"""The meridian offset inward in the half-plane, for the method `revolved`."""
