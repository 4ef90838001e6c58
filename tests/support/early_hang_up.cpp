#include <csignal>

// A library to start a program with (LD_PRELOAD): it sends SIGHUP while the program's libraries initialise.

namespace {

[[gnu::constructor]] void HangUp() { std::raise(SIGHUP); }

}  // namespace
