"""The teleoperation station: people drive the arm by what one fixed camera shows (paper section IV-C)."""
