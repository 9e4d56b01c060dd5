"""Low-level tools of both packages: compiled loops, vectors, threads, memory, splines."""
