#pragma once

// Which sanitizer a test is built with: CHEQUER_ADDRESS_SANITIZER, CHEQUER_THREAD_SANITIZER. Compilers say so in ways
// of their own.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CHEQUER_ADDRESS_SANITIZER
#endif
#if __has_feature(thread_sanitizer)
#define CHEQUER_THREAD_SANITIZER
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define CHEQUER_ADDRESS_SANITIZER
#endif
#ifdef __SANITIZE_THREAD__
#define CHEQUER_THREAD_SANITIZER
#endif
