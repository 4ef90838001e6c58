// cells ID: prints the colours of a 6x6 secded marker's cells, row by row: what a page has to show.
#include <cstdio>
#include <cstdlib>

#include "chequer/marker.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const chequer::MarkerSize size{6, 6};
  const chequer::MarkerCode code(size, chequer::Variant::kSecded);
  std::printf("%s\n", chequer::CellColours(size, code.Encode(std::strtoull(argv[1], nullptr, 10))).c_str());
}
