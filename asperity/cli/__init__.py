"""The command line: argparse, one call of the public function, one write."""
