#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace chequer {

/// The headers of every answer: nothing from elsewhere runs on the page, and no page elsewhere shows it.
struct HttpHeader {
  const char* name;
  const char* value;
};
inline constexpr HttpHeader kSafetyHeaders[] = {
    {"content-security-policy:", "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
    {"x-content-type-options:", "nosniff"},
    {"x-frame-options:", "DENY"},
    {"referrer-policy:", "no-referrer"},
    {"cross-origin-resource-policy:", "same-origin"},
    {"cross-origin-opener-policy:", "same-origin"},
    {"cache-control:", "no-cache"},
};

/// Who may be served. A page elsewhere can make a browser send requests here, also under a name of its own that it lets
/// point here; the headers Host and Origin tell them.
class HttpRules {
 public:
  /// @param names of this host, beside "localhost" and numbers.
  explicit HttpRules(std::vector<std::string> names) : names_(std::move(names)) {}

  /// Whether a Host header names this server: a number (which no name's owner can turn elsewhere), localhost, or one of
  /// its names; with or without a port.
  bool HostIsOurs(std::string_view host) const;
  /// Whether a page of that origin may open the WebSocket: it was served under that very host. A request without an
  /// origin comes from no page.
  bool OriginIsOurs(std::string_view origin, std::string_view host) const;

 private:
  std::vector<std::string> names_;
};

}  // namespace chequer
