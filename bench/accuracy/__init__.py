"""What accuracy costs in time: errors against an independent truth, beside times and peers."""
