"""generator_test.py GENERATOR COMPILER: types with every kind of member, decoded in Python, C and C++."""

import os
import random
import struct
import subprocess
import sys
import tempfile
import unittest

GENERATOR, COMPILER = sys.argv.pop(1), sys.argv.pop(1)

INNER = "package own;\nstruct inner_t { string s; }\n"
# Comments with what looks like code, constants, counts of several widths, lists of lists.
ALL = """// struct no_t {
package own;
/* int32_t none; */
struct all_t {
  const int32_t THREE = 3, FOUR = 4;
  int32_t n, length;  // a count may have any name
  int8_t pos;
  double values[n];
  byte raw[ length ];
  string names[n];
  inner_t items[n];
  float grid[n][3];
  float turned[3][n];
  int16_t two[n][pos];
  boolean flags[pos];
  string fixed[4];
  own.inner_t fixed_items[2];
}
"""
MAIN = r"""
#ifdef IN_C
extern "C" {
#include "own_all_t.h"
}
int Decode(const unsigned char* data, int size) {
  own_all_t message = {};
  const int read = own_all_t_decode(data, 0, size, &message);
  if (read >= 0) own_all_t_decode_cleanup(&message);
  return read;
}
#else
#include "own/all_t.hpp"
int Decode(const unsigned char* data, int size) { return own::all_t().decode(data, 0, size); }
#endif
#include <cstdio>
#include <vector>
int main() {  // messages, each behind its length; prints whether each is understood
  int size = 0;
  while (std::fread(&size, sizeof size, 1, stdin) == 1) {
    std::vector<unsigned char> data(size);
    if (std::fread(data.data(), 1, data.size(), stdin) != data.size()) return 2;
    std::putchar(Decode(data.data(), size) >= 0 ? '1' : '0');
  }
}
"""


def generate(language, folder, files):
    return subprocess.run([sys.executable, GENERATOR, language, folder, *files], capture_output=True, text=True)


def write(folder, name, text):
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


class GeneratorTest(unittest.TestCase):
    def setUp(self):
        self.folder_owner = tempfile.TemporaryDirectory()
        self.folder = self.folder_owner.name
        self.addCleanup(self.folder_owner.cleanup)

    def refusal(self, *texts):
        files = [write(self.folder, f"{i}.lcm", text) for i, text in enumerate(texts)]
        result = generate("python", self.folder, files)
        self.assertNotEqual(result.returncode, 0)
        return result.stderr

    def test_refuses_what_it_cannot_make_safe(self):
        self.assertIn("holds itself", self.refusal("package own;\nstruct a_t { int32_t n; a_t more[n]; }"))
        self.assertIn("is in none of the files", self.refusal("package own;\nstruct a_t { other.b_t b; }"))
        self.assertIn("no whole number", self.refusal("package own;\nstruct a_t { double n; int8_t x[n]; }"))
        self.assertIn("cannot read", self.refusal("package own;\nenum e_t { A, B }"))

    def test_refuses_an_lcm_gen_that_it_does_not_know(self):
        fake = write(self.folder, "lcm-gen", "#!/bin/sh\nmkdir -p \"$3/own\"\necho other >\"$3/own/inner_t.py\"\n")
        os.chmod(fake, 0o755)
        path = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", path)
        os.environ["PATH"] = self.folder + ":" + path
        self.assertIn("does not know the decoders", self.refusal(INNER))

    def messages(self):
        """Messages that are right, and what chance makes of them, with whether they are right still."""
        import own

        rng = random.Random(1)
        for _ in range(300):
            message = own.all_t()
            message.n, message.length, message.pos = rng.randrange(4), rng.randrange(5), rng.randrange(3)
            message.values = [0.5] * message.n
            message.raw = bytes(message.length)
            message.names = ["name"] * message.n
            inner = own.inner_t()
            message.items = [inner] * message.n
            message.grid = [[1.0, 2.0, 3.0]] * message.n
            message.turned = [[1.0] * message.n] * 3
            message.two = [[7] * message.pos] * message.n
            message.flags = [True] * message.pos
            message.fixed = ["x", "", "yy", "z"]
            message.fixed_items = [inner] * 2
            data = message.encode()
            yield data, True
            yield data[: rng.randrange(len(data))], False
            for count in (-1, -(2**31), 2**31 - 1):
                yield data[:8] + struct.pack(">i", count) + data[12:], False
            yield data[:16] + b"\x80" + data[17:], False
            at = rng.randrange(8, len(data))
            yield data[:at] + bytes([rng.randrange(256)]) + data[at + 1:], None

    def test_every_language_understands_and_refuses_the_same(self):
        files = [write(self.folder, "inner.lcm", INNER), write(self.folder, "all.lcm", ALL)]
        for language in ("python", "c", "cpp"):
            result = generate(language, os.path.join(self.folder, language), files)
            self.assertEqual(result.returncode, 0, result.stderr)
        sys.dont_write_bytecode = True
        sys.path.insert(0, os.path.join(self.folder, "python"))
        import own

        data, understood = b"", ""
        for message, right in self.messages():
            try:
                own.all_t.decode(message)
                answer = "1"
            except ValueError:
                answer = "0"
            if right is not None:
                self.assertEqual(answer, "1" if right else "0", message.hex())
            data += struct.pack("=i", len(message)) + message
            understood += answer
        main = write(self.folder, "main.cpp", MAIN)
        flags = subprocess.run(["pkg-config", "--cflags", "--libs", "lcm"], capture_output=True, text=True, check=True)
        for language, sources in (("c", ["c/own_all_t.c", "c/own_inner_t.c"]), ("cpp", [])):
            program = os.path.join(self.folder, "decode_" + language)
            subprocess.run(
                # LCM's own header copies no bytes to nowhere where a list is empty.
                [COMPILER, "-w", "-g", "-fsanitize=address,undefined", "-fno-sanitize=nonnull-attribute",
                 "-fno-sanitize-recover=all", *(["-DIN_C"] if language == "c" else []),
                 "-I" + os.path.join(self.folder, language), "-x", "c++", main, *(os.path.join(self.folder, source) for source in sources), "-o", program, *flags.stdout.split()],
                check=True)
            result = subprocess.run([program], input=data, capture_output=True)
            self.assertEqual(result.returncode, 0, result.stderr.decode())
            self.assertEqual(result.stdout.decode(), understood, language)


if __name__ == "__main__":
    unittest.main(verbosity=2)
