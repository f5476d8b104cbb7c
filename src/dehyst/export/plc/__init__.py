"""Program organisation units as data, and their text for CODESYS and TwinCAT, for Siemens SCL, and as PLCopen XML."""
