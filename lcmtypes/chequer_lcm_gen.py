"""chequer_lcm_gen.py c|cpp|python FOLDER FILE.lcm...: writes decoders that refuse hostile messages.

Runs lcm-gen, then puts a check before each decoder. What lcm-gen writes believes a message's counts and lengths, so
a few bytes from the network end a program or take all its memory. The check walks through the bytes first, without
taking memory. It refuses a message whose counts are negative, or that is shorter than its counts and texts say.

All types that the files use must be among the files. Needs lcm-gen (Debian: liblcm-bin) on the PATH.
"""

import os
import re
import subprocess
import sys

SIZES = {"int8_t": 1, "byte": 1, "boolean": 1, "int16_t": 2, "int32_t": 4, "float": 4, "int64_t": 8, "double": 8}
COUNTS = {"int8_t": "b", "int16_t": "h", "int32_t": "i", "int64_t": "q"}  # with their letters in Python's struct
NAME = r"[A-Za-z_][A-Za-z0-9_]*"


class Member:
    def __init__(self, type_name, name, dimensions):
        self.type, self.name, self.dimensions = type_name, name, dimensions


class Struct:
    """One type of a .lcm file. `name` has its package: "chequer.poses_t"."""

    def __init__(self, package, name, body):
        self.package, self.short = package, name
        self.name = f"{package}.{name}" if package else name
        self.members = []
        for statement in filter(None, (part.strip() for part in body.split(";"))):
            if re.match(r"const\s", statement):
                continue
            parts = re.fullmatch(rf"((?:{NAME}\.)*{NAME})\s+(.*)", statement, re.S)
            if not parts:
                raise ValueError(f"{self.name}: cannot read '{statement}'")
            for declared in parts[2].split(","):
                member = re.fullmatch(rf"\s*({NAME})\s*((?:\[[^\]]*\]\s*)*)", declared)
                if not member:
                    raise ValueError(f"{self.name}: cannot read '{statement}'")
                sizes = [size.strip() for size in re.findall(r"\[([^\]]*)\]", member[2])]
                self.members.append(Member(self.resolve(parts[1]), member[1], sizes))
        self.counts = {size for member in self.members for size in member.dimensions if not size.isdigit()}
        for count in self.counts:
            if not any(member.name == count and member.type in COUNTS for member in self.members):
                raise ValueError(f"{self.name}: '{count}' is no whole number that a count can be")

    def resolve(self, type_name):
        is_own = type_name not in SIZES and type_name != "string" and "." not in type_name
        return f"{self.package}.{type_name}" if is_own and self.package else type_name


def read_types(paths):
    types = {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            text = re.sub(r"/\*.*?\*/|//[^\n]*", "", file.read(), flags=re.S)
        package = ""
        for declaration in re.finditer(rf"package\s+([^;\s]+)\s*;|struct\s+({NAME})\s*\{{(.*?)\}}|\S+", text, re.S):
            if declaration[1]:
                package = declaration[1]
            elif declaration[2]:
                struct = Struct(package, declaration[2], declaration[3])
                types[struct.name] = struct
            else:
                raise ValueError(f"{path}: cannot read '{declaration[0]}'")
    for struct in types.values():
        check_nesting(types, struct, [])
    return types


def check_nesting(types, struct, within):
    if struct.name in within:
        raise ValueError(f"{struct.name} holds itself: a message could end a program by its depth")
    for member in struct.members:
        if member.type in SIZES or member.type == "string":
            continue
        if member.type not in types:
            raise ValueError(f"{struct.name}: {member.type} is in none of the files")
        check_nesting(types, types[member.type], within + [struct.name])


class CheckWriter:
    """Writes the check of one type, statement by statement; subclasses know the language."""

    def __init__(self, struct):
        self.lines, self.skipped, self.depth = [], 0, 1
        for member in struct.members:
            if member.name in struct.counts and not member.dimensions:
                self.flush()
                self.count(member)
            else:
                self.member(member, list(member.dimensions))
        self.flush()

    def put(self, line):
        self.lines.append(self.INDENT * self.depth + line)

    def flush(self):
        """Numbers that follow each other are skipped together."""
        if self.skipped:
            self.skip(str(self.skipped))
        self.skipped = 0

    def member(self, member, dimensions):
        size = SIZES.get(member.type)
        while size and dimensions and dimensions[-1].isdigit():
            size *= int(dimensions.pop())
        if not dimensions:
            if size:
                self.skipped += size
                return
            self.flush()
            if member.type == "string":
                self.text()
            else:
                self.struct(member.type)
            return
        self.flush()
        count = dimensions[0] if dimensions[0].isdigit() else f"count_{dimensions[0]}"
        if not count.isdigit():
            self.bound(count)
        if size and len(dimensions) == 1:
            self.skip_many(count, size)
            return
        self.begin_loop(len(dimensions), count)
        self.depth += 1
        self.member(member, dimensions[1:])
        self.flush()
        self.depth -= 1
        self.end_loop()


class CCheck(CheckWriter):
    INDENT = "    "

    def __init__(self, struct, function_of):
        self.function_of = function_of
        super().__init__(struct)

    def count(self, member):
        decode = f"__{member.type}_decode_array(buf, offset + pos, maxlen - pos, &count_{member.name}, 1)"
        self.put(f"{member.type} count_{member.name};")
        self.put(f"if ({decode} < 0) return -1;")
        self.put(f"pos += {SIZES[member.type]};")

    def skip(self, size):
        self.put(f"if (maxlen - pos < {size}) return -1;")
        self.put(f"pos += {size};")

    def bound(self, count):
        self.put(f"if ({count} < 0 || {count} > maxlen - pos) return -1;")

    def skip_many(self, count, size):
        self.put(f"if ({count} > (maxlen - pos) / {size}) return -1;")
        self.put(f"pos += (int) {count} * {size};")

    def text(self):
        self.put("{ int32_t length;")
        self.put("if (__int32_t_decode_array(buf, offset + pos, maxlen - pos, &length, 1) < 0) return -1;")
        self.put("pos += 4;")
        self.put("if (length < 1 || length > maxlen - pos) return -1;")
        self.put("pos += length;")
        self.put("if (((const char*) buf)[offset + pos - 1] != 0) return -1; }")

    def struct(self, name):
        self.put(f"{{ int length = {self.function_of(name)}(buf, offset + pos, maxlen - pos);")
        self.put("if (length < 0) return length;")
        self.put("pos += length; }")

    def begin_loop(self, level, count):
        self.put(f"for (int i{level} = 0; i{level} < {count}; i{level}++) {{")

    def end_loop(self):
        self.put("}")

    def function(self, name):
        return (
            "/* Added by chequer_lcm_gen.py: how many bytes a message has, or -1 where it is shorter than it says. */\n"
            f"int {name}(const void *buf, int offset, int maxlen)\n{{\n"
            "    int pos = 0;\n    (void) buf; (void) offset; (void) maxlen;\n"
            + "\n".join(self.lines) + "\n    return pos;\n}\n\n"
        )


class PythonCheck(CheckWriter):
    INDENT = "    "

    def put(self, line):
        self.lines.append(self.INDENT * (self.depth + 1) + line)

    def refuse_if(self, condition):
        self.put(f"if {condition}:")
        self.put('    raise ValueError("the message is shorter than it says")')

    def count(self, member):
        size = SIZES[member.type]
        self.refuse_if(f"len(data) - pos < {size}")
        self.put(f"count_{member.name} = struct.unpack_from('>{COUNTS[member.type]}', data, pos)[0]")
        self.put(f"pos += {size}")

    def skip(self, size):
        self.refuse_if(f"len(data) - pos < {size}")
        self.put(f"pos += {size}")

    def bound(self, count):
        self.refuse_if(f"not 0 <= {count} <= len(data) - pos")

    def skip_many(self, count, size):
        self.skip(f"{count} * {size}")

    def text(self):
        self.refuse_if("len(data) - pos < 4")
        self.put("length = struct.unpack_from('>i', data, pos)[0]")
        self.put("pos += 4 + length")
        self.refuse_if("length < 1 or pos > len(data) or data[pos - 1] != 0")

    def struct(self, name):
        self.put(f"pos = {name}._check_bounds(data, pos)")

    def begin_loop(self, level, count):
        self.put(f"for _ in range({count}):")

    def end_loop(self):
        pass

    def function(self):
        return (
            "    # Added by chequer_lcm_gen.py: where the message ends; ValueError where it is shorter than it says.\n"
            "    def _check_bounds(data, pos):\n" + "\n".join(self.lines) + "\n        return pos\n"
            "    _check_bounds = staticmethod(_check_bounds)\n\n"
        )


def before(place, added):
    return place, added + place


def after(place, added):
    return place, place + added


def edit(path, *changes):
    """Each change is (what is there now, what is to be): the place must be there exactly once."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for place, wanted in changes:
        if text.count(place) != 1:
            raise ValueError(f"{path}: this program does not know the decoders of this lcm-gen: where is '{place}'?")
        text = text.replace(place, wanted)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def write_c(types, folder, files):
    subprocess.run(["lcm-gen", "-c", "--c-cpath", folder, "--c-hpath", folder, *files], check=True)
    for name, struct in types.items():
        c_name = name.replace(".", "_")
        checker = f"__{c_name}_bounds"
        check = CCheck(struct, lambda other: f"__{other.replace('.', '_')}_bounds")
        prototype = f"int     {checker}(const void *buf, int offset, int maxlen);\n"
        call = f"    if ({checker}(buf, offset + pos, maxlen - pos) < 0) return -1;\n"
        edit(f"{folder}/{c_name}.h", before(f"int     __{c_name}_decode_array(", prototype))
        edit(
            f"{folder}/{c_name}.c",
            before(f"int {c_name}_decode(const void *buf", check.function(checker)),
            after("    if (this_hash != hash) return -1;\n", call),
        )


def write_cpp(types, folder, files):
    subprocess.run(["lcm-gen", "-x", "--cpp-std", "c++11", "--cpp-hpath", folder, *files], check=True)
    prototype = "        inline static int _checkBounds(const void *buf, int offset, int maxlen);\n"
    call = "    if (_checkBounds(buf, offset + pos, maxlen - pos) < 0) return -1;\n"
    for name, struct in types.items():
        check = CCheck(struct, lambda other: f"::{other.replace('.', '::')}::_checkBounds")
        edit(
            f"{folder}/{name.replace('.', '/')}.hpp",
            before("        inline int _decodeNoHash(", prototype),
            before(f"int {struct.short}::decode(const void *buf", check.function(f"{struct.short}::_checkBounds")),
            after("    if (msg_hash != getHash()) return -1;\n", call),
        )


def write_python(types, folder, files):
    subprocess.run(["lcm-gen", "-p", "--ppath", folder, *files], check=True)
    for name, struct in types.items():
        call = ("        begin = buf.tell()\n"
                f"        {struct.short}._check_bounds(buf.read(), 0)\n"
                "        buf.seek(begin)\n")
        edit(
            f"{folder}/{name.replace('.', '/')}.py",
            before("    def decode(data):\n", PythonCheck(struct).function()),
            after('            raise ValueError("Decode error")\n', call),
        )


def main():
    writers = {"c": write_c, "cpp": write_cpp, "python": write_python}
    if len(sys.argv) < 4 or sys.argv[1] not in writers:
        sys.exit("usage: chequer_lcm_gen.py c|cpp|python FOLDER FILE.lcm...")
    folder, files = sys.argv[2], sys.argv[3:]
    os.makedirs(folder, exist_ok=True)
    writers[sys.argv[1]](read_types(files), folder, files)


if __name__ == "__main__":
    try:
        main()
    except (ValueError, OSError, subprocess.CalledProcessError) as problem:
        sys.exit(f"chequer_lcm_gen.py: {problem}")
