"""What pages of several kinds share: boards, views, cameras, scores."""
