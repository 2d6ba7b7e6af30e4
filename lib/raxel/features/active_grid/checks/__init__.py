"""What the images of an active grid say against themselves, beside the decoding."""
