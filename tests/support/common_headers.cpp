// The unit for which common_headers.h is compiled; nothing of its own.
