"""The moving beam as a film."""
