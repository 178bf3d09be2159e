"""Stations: a container, a glass and a filling become a scene as one camera of the line, or a designer, sees it."""

from glassworkbench.staging.catalogue import check_station, described, station, stations
from glassworkbench.staging.contents import Fill, parse_fill
from glassworkbench.staging.pose import Pose
from glassworkbench.staging.sample import sample_container

__all__ = ["Fill", "Pose", "check_station", "described", "parse_fill", "sample_container", "station", "stations"]
