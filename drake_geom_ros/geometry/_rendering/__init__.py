"""PRIVATE: posed shapes and a camera in, images out; arrays only. Compiled on first use."""
