#include "view/http_rules.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>

namespace chequer {
namespace {

constexpr std::size_t kMostHostCharacters = 255;

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

/// The name in a Host header, without brackets and port; empty where it is none.
std::string NameIn(std::string_view host) {
  if (host.empty() || host.size() > kMostHostCharacters) return {};
  std::string_view name = host, rest;
  if (host.front() == '[') {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return {};
    name = host.substr(1, end - 1);
    rest = host.substr(end + 1);
  } else if (const std::size_t colon = host.find(':'); colon != std::string_view::npos) {
    name = host.substr(0, colon);
    rest = host.substr(colon);
  }
  const bool port = rest.size() >= 2 && rest.size() <= 6 && rest.front() == ':' &&
                    std::all_of(rest.begin() + 1, rest.end(), [](char c) { return c >= '0' && c <= '9'; });
  return rest.empty() || port ? Lower(name) : std::string();
}

bool IsNumber(const std::string& name) {
  in_addr v4{};
  in6_addr v6{};
  return inet_pton(AF_INET, name.c_str(), &v4) == 1 || inet_pton(AF_INET6, name.c_str(), &v6) == 1;
}

}  // namespace

bool HttpRules::HostIsOurs(std::string_view host) const {
  const std::string name = NameIn(host);
  if (name.empty() || name.find('\0') != std::string::npos) return false;
  return name == "localhost" || IsNumber(name) ||
         std::any_of(names_.begin(), names_.end(), [&](const std::string& own) { return Lower(own) == name; });
}

bool HttpRules::OriginIsOurs(std::string_view origin, std::string_view host) const {
  return HostIsOurs(host) && Lower(origin) == "http://" + Lower(host);
}

}  // namespace chequer
