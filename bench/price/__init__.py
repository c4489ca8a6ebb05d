"""What accuracy costs on scenes with a long record and a short one."""
