"""One scene under many ground motions."""
