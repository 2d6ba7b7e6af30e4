"""What the pictures of an active grid say against themselves, beside the decoding."""
