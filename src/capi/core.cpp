// The WebAssembly module of js/: nothing but what sqmap.h declares, which the linker is told to export.
int main() { return 0; }
