"""What users pass: turned into what kernels take, or refused in one line."""
