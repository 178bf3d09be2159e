"""Stations: a container, a glass and a filling become a scene as one camera of the line, or a designer, sees it."""

from glassworkbench.stations.catalogue import check_station, station, stations
from glassworkbench.stations.contents import Fill, parse_fill
from glassworkbench.stations.sample import sample_container

__all__ = ["Fill", "check_station", "parse_fill", "sample_container", "station", "stations"]
