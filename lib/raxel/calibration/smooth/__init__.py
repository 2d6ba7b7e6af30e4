"""B-spline ray fields: a parametric model plus a smooth field of its residuals."""
