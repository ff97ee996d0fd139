"""The reference implementation: one METHOD a file, thin over the C kernels."""
