"""Where rows come from: a growing file, standard input, MQTT, OPC UA; nothing is written to a machine."""
