#include "support/temporary_directory.h"

#include <stdlib.h>  // mkdtemp is POSIX, not C++

#include <system_error>

namespace chequer::test {

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "chequer-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;  // a leftover in the temporary folder is no failure of the test
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace chequer::test
