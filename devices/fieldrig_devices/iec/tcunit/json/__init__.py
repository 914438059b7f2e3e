"""The library Tc3_JsonXml for suites, as far as it is about JSON."""
