"""AprilTags in the pictures of one camera: pictures in, placements of the tags out."""
