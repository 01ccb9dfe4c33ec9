from .payload.largest_mass import find_payload as find_payload
