module bw_design_par
  !! `&design`: a table with a column for each number that varies and a row for each case.
  use bw_input_name, only: input_group, input_name, text_input
  implicit none (type, external)
  private

  type, public :: design_par
    character(:), allocatable :: file        !! as the user gave it, relative to the scene
    integer :: line = 0                      !! line of the scene that names it
    character(:), allocatable :: path        !! path to the file
    character(:), allocatable :: checksum    !! of the table's bytes, in hexadecimal digits
    integer, allocatable :: lines(:)         !! line of the table for each row, (rows)
  end type design_par

  type(input_group), parameter, public :: design_group = input_group( &
    'design', absent='one case, or those of `&sweep`', &
    physics='Runs the scene once for each row of a table: a random sample of uncertain inputs, or a design of experiments.', &
    example='&beam length = 1.2, density = 2700 /|&rotation /|&damping /|&impact /|&contact exponent = 1 /|&modes before = '// &
    '20 /|&response duration = 0.1, samples = 512, bending_moment = .true. /|&design file = ''input/designs/boom.csv'' /', &
    rules='The table is a text file: a line of names, then a line of numbers for each case, separated by commas, semicolons, '// &
    'tabs or blanks. A name is `group%name`, with the rules of `sweep%parameter`: a number that `&sweep` may vary, of a group '// &
    'that is present; a value given there is replaced. Empty lines and lines that begin with `#` are ignored; names and '// &
    'numbers may be quoted; the decimal mark is a point. All rows are checked before the first case is run. `&design` excludes '// &
    '`&sweep` and `&identify`. Every column needs a name; with pandas write the table without its index: `to_csv(index=False)`.')

  type(input_name), parameter, public :: design_names(*) = [ &
    input_name('design', 'file', text_input, required=.true., &
               meaning='the table, beside the scene: a column for each number, a row for each case')]

end module bw_design_par
