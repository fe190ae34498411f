// The WebAssembly module of js/: it exports the functions of sqmap.h alone.
int main() { return 0; }
