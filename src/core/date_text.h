#pragma once

#include <string_view>

namespace chequer {

/// Whether a text can be a date as files hold it ("2024-05-01T12:00:00Z"): letters, digits, spaces and : . + - alone,
/// so that it can be written between quotes.
bool IsDateText(std::string_view text);

}  // namespace chequer
