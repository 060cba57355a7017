"""Pictures of plans, drawn with matplotlib (imported when a picture is asked for)."""
