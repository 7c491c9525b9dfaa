"""Files of fields for ParaView."""
