"""The claims of S. Rauch-Wojciechowski and N. Rutstam on the dynamics of the tippe top."""
