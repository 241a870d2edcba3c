"""The vehicle: its data, its equations (1)-(9), its trim."""
