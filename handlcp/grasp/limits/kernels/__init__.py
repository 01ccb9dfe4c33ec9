"""A path under a growing load, compiled: from event to event."""
