# Turns a .pf file of the subset into Fortran:  awk -v name=test_x -v names=funit.f90 -f directives.awk test_x.pf > test_x.f90
#
# @test names the next subroutine as a test; an assertion becomes a call and a return when it failed.
# After the module comes another, <name>_suite, whose run_suite runs the tests in the file's order.
# Line markers keep the compiler's messages in terms of the .pf file. What pFUnit would drop or
# leave to the compiler is refused here: exit status 1.

function refuse(why) {
  printf "%s:%d: %s\n", FILENAME, FNR, why > "/dev/stderr"
  refused = 1
}

function mark(line) {
  printf "# %d \"%s\"\n", line, FILENAME
}

function assertion(    indent, call_text) {
  match($0, /^[ \t]*/)
  indent = substr($0, 1, RLENGTH)
  call_text = substr($0, RLENGTH + 2)
  sub(/\)[ \t]*$/, ", \\&", call_text)
  mark(FNR)
  print indent "call " call_text
  print indent "  location=SourceLocation('" name ".pf', " FNR "))"
  print indent "if (anyExceptions()) return"
  mark(FNR + 1)
}

function named_test(    words) {
  waiting = 0
  if (tolower($0) !~ /^[ \t]*subroutine[ \t]+[a-z][a-z0-9_]*[ \t]*(\([ \t]*\))?[ \t]*(!.*)?$/)
    return refuse("@test must stand before 'subroutine NAME()', without prefixes or arguments")
  sub(/^[ \t]*[a-zA-Z]+[ \t]+/, "", $0)
  match($0, /^[a-zA-Z0-9_]+/)
  tests[++count] = substr($0, 1, RLENGTH)
}

# A declaration names nothing as pFUnit's types, nor in the module what pFUnit declares where it lists the tests.
function check_names(    declared, list, i, n) {
  declared = tolower($0)
  gsub(/'[^']*'|"[^"]*"/, "", declared)
  sub(/!.*/, "", declared)
  if (!sub(/^[^(]*(\([^:]*\)[^:]*)?::/, "", declared)) return
  while (gsub(/\([^()]*\)/, "", declared)) continue
  n = split(declared, list, ",")
  for (i = 1; i <= n; i++) {
    sub(/=.*/, "", list[i])
    gsub(/[ \t]/, "", list[i])
    if (list[i] in taken || (!contained && list[i] ~ /^(suite|t)$/)) refuse("pFUnit has a name " list[i] " of its own")
  }
}

BEGIN {
  while ((getline line < names) > 0 && !(listed && line !~ /^    /)) {
    if (line ~ /integer, parameter, public/) listed = 1      # the first such list, of types
    while (listed && match(line, /[a-z_]+ = 0/)) {
      taken[substr(line, RSTART, RLENGTH - 4)]
      line = substr(line, RSTART + RLENGTH)
    }
  }
  known = "^[ \t]*@assert(equal|relativelyequal|lessthanorequal|true|false)[ \t]*[(].*[^ \t].*[)][ \t]*$"
  waiting = count = refused = contained = 0
}

/^[ \t]*@/ {
  if (length($0) > 120) refuse("a directive ends within 120 columns")
  if (waiting) refuse("@test must stand before 'subroutine NAME()'")
  if (tolower($0) ~ /^[ \t]*@test[ \t]*$/) {
    waiting = 1
    print ""
  } else if (tolower($0) ~ known) {
    assertion()
  } else {
    refuse("not a directive of the subset (one line each; see tests/README.md): " $0)
  }
  next
}

module == "" && tolower($0) ~ /^[ \t]*module[ \t]+[a-z][a-z0-9_]*[ \t]*$/ {
  module = $2
  if (tolower(module) != tolower(name)) refuse("the module of " name ".pf must be named " name)
}

{
  print
  if (tolower($0) ~ /^[ \t]*contains[ \t]*$/) contained = 1
  check_names()
  if (waiting && $0 !~ /^[ \t]*(!.*)?$/) named_test()
}

END {
  if (waiting) refuse("@test without a subroutine")
  if (module == "") refuse("no module")
  print ""
  print "module " name "_suite"
  print "  use funit, only: run_test"
  if (count) {
    print "  use " name ", only: &"
    for (i = 1; i <= count; i++) print "    " tests[i] (i < count ? ", &" : "")
  }
  print "  implicit none (type, external)"
  print "  private"
  print "  public :: run_suite"
  print "contains"
  print "  subroutine run_suite()"
  for (i = 1; i <= count; i++) {
    print "    call run_test('" name "', &"
    print "      '" tests[i] "', &"
    print "      " tests[i] ")"
  }
  print "  end subroutine run_suite"
  print "end module " name "_suite"
  exit refused
}
