"""What the views of planar targets say: which point does each pixel see?"""
