module bw_scene_describe
  !! The description of every input name with type, unit, range, default and meaning: plain text that is also Markdown.
  use bw_columns, only: text_width, wrapped
  use bw_effect_table, only: effect_table
  use bw_error, only: error_type, fail, status_bad_input
  use bw_input_name, only: has_unit, input_group, input_name, is_sweepable, kind_text, quoted_words, &
                           range_text
  use bw_input_table, only: group_row, group_table, name_table, rows_of, unknown_group
  use bw_text, only: lines_of, lower, replaced, shortened, string, text_builder, words_of
  implicit none (type, external)
  private
  public :: describe_text

  integer, parameter :: columns = 6, widest = 80
  character(*), parameter :: heads(columns) = [character(7) :: 'name', 'type', 'unit', 'range', 'default', 'meaning']

  character(*), parameter :: opening(*) = [character(120) :: &
    '# The scene: every input name', &
    '', &
    'A scene is a file of Fortran namelist groups, in SI units. An effect whose group is absent is not simulated. All', &
    'errors of a file are reported at once, each with its line.', &
    '', &
    '```fortran', &
    '&beam', &
    '  length = 1, density = 7870, youngs_modulus = 2e11, diameter = 0.037  ! comments open with !', &
    '/', &
    '&rotation angular_velocity = 50 /', &
    '```', &
    '', &
    'Add a `&beam` to the examples that have none: each is then a complete scene.', &
    '', &
    '- A group opens with `&name` and ends with `/`. Groups may have any order. Each may occur once; `&body`, `&force`,', &
    '  `&base`, `&identify` and `&sweep` may be repeated. Between groups only comments and blanks are allowed. `&end`', &
    '  and `$name` are not accepted.', &
    '- Names and words are case-insensitive. Each name may occur once in its group. `group%name = ...` and', &
    '  `name(1) = ...` are not accepted.', &
    '- Values are separated by commas, blanks or line ends; a comma may follow the last. `3*0.5` is 0.5 three times.', &
    '  A missing value (`1,,2`, `2*`, `name =`), which in Fortran keeps the previous value, is an error.', &
    '- A real is written `7870`, `.5`, `2e11` or `2d11`; a whole number has only digits. `1/2`, `1.0-3`, NaN, Inf and', &
    '  numbers beyond double precision are errors. -0 is read as 0.', &
    '- Numbers out of proportion to the beam are errors: in units of its length l, its mass m and the time', &
    '  sqrt(m l^3/(EI)) a number must be 0 or between 1e-60 and 1e60. A stiffer spring is treated as rigid.', &
    '- A logical is `.true.`, `true`, `.t.` or `t`, or the same with false or f.', &
    '- A text is enclosed in `''` or `"` on one line; write a quote inside it twice. Trailing blanks are dropped.', &
    '- The file is UTF-8 with LF or CR LF line ends. Non-ASCII characters may occur in texts and comments only.', &
    '- A file has at most 64 MB, 2^22 words and signs, and 1000 groups. If there are more than 1000 errors, the first', &
    '  1000 are listed.']

contains

  function describe_text(group, error) result(text)
    !! Describe one group, or how a scene is written and all groups; without the last line end.
    character(*), intent(in) :: group             !! with or without `&`, in any case; '' for all
    character(:), allocatable :: text
    type(error_type), allocatable, intent(out) :: error   !! `status_bad_input` for an unknown group
    type(text_builder) :: builder
    character(:), allocatable :: name
    integer :: i
    name = lower(trim(adjustl(group)))
    if (index(name, '&') == 1) name = name(2:)
    if (name /= '' .and. group_row(name) == 0) then
      text = ''
      call fail(error, status_bad_input, "'"//shortened(name)//"' "//unknown_group(name))
      return
    end if
    do i = 1, merge(size(opening), 0, name == '')
      call builder%append_line(trim(opening(i)))
    end do
    do i = 1, size(group_table)
      if (name /= '' .and. name /= group_table(i)%name) cycle
      if (name == '') call builder%append_line('')
      call put_group(builder, group_table(i))
    end do
    if (name == '') call put_effects(builder)
    text = builder%text()
    text = text(:len(text) - 1)
  end function describe_text

  pure subroutine put_effects(builder)
    !! List the effects that a scene may have, as `beamwave effects` compares them.
    type(text_builder), intent(inout) :: builder
    character(widest) :: cells(2, 0:size(effect_table))
    integer :: width(2), i
    cells(:, 0) = [character(widest) :: 'effect', 'compared with']
    do i = 1, size(effect_table)
      cells(:, i) = [character(widest) :: '`'//trim(effect_table(i)%name)//'`', effect_table(i)%beside]
    end do
    width = maxval(len_trim(cells), dim=2)
    call builder%append_line('')
    call builder%append_line('## What `beamwave effects` compares')
    call builder%append_line('')
    do i = 0, size(effect_table)
      call put_row(builder, cells(:, i), width)
      if (i == 0) call put_row(builder, [repeat('-', widest), repeat('-', widest)], width)
    end do
  end subroutine put_effects

  pure subroutine put_group(builder, group)
    !! Describe one group: the meaning of its absence, a table of names, its rules.
    type(text_builder), intent(inout) :: builder
    type(input_group), intent(in) :: group
    integer, allocatable :: rows(:)
    integer :: i
    rows = rows_of(group%name)
    call builder%append_line('## &'//trim(group%name))
    call builder%append_line('')
    call put_wrapped(builder, trim(group%physics))
    call builder%append_line('')
    call put_wrapped(builder, 'Absent: '//trim(group%absent)//'.')
    call put_needs(builder, group)
    if (size(rows) == 0) then
      call builder%append_line('')
      call builder%append_line('It has no names.')
    else
      call put_table(builder, rows)
    end if
    do i = 1, size(rows)
      if (name_table(rows(i))%words == '') cycle
      call builder%append_line('')
      call put_wrapped(builder, '`'//trim(name_table(rows(i))%name)//'` is one of '//quoted_words(name_table(rows(i))%words)//'.')
    end do
    if (group%rules /= '') then
      call builder%append_line('')
      call put_wrapped(builder, trim(group%rules))
    end if
    if (any(is_sweepable(name_table(rows)))) then
      call builder%append_line('')
      call put_wrapped(builder, swept_text(rows))
    end if
    call put_example(builder, group%example)
  end subroutine put_group

  pure subroutine put_example(builder, example)
    !! Put the lines of an example, as a code block.
    type(text_builder), intent(inout) :: builder
    character(*), intent(in) :: example
    call builder%append_line('')
    call builder%append_line('```fortran')
    call builder%append_line(replaced(trim(example), '|', new_line('a')))
    call builder%append_line('```')
  end subroutine put_example

  pure subroutine put_needs(builder, group)
    !! Put the groups that a group needs or excludes, if any.
    type(text_builder), intent(inout) :: builder
    type(input_group), intent(in) :: group
    character(:), allocatable :: text
    text = ''
    if (group%needs /= '') text = ' Needs '//listed(group%needs, 'and')//'.'
    if (group%excludes /= '') text = text//' Cannot be combined with '//listed(group%excludes, 'or')//'.'
    if (text == '') return
    call builder%append_line('')
    call put_wrapped(builder, text(2:))
  end subroutine put_needs

  pure function listed(groups, between) result(text)
    !! List groups in words.
    character(*), intent(in) :: groups            !! by blanks; by `|` where one of them is enough
    character(*), intent(in) :: between           !! conjunction of the last two
    character(:), allocatable :: text
    type(string), allocatable :: names(:)
    integer :: i
    names = words_of(replaced(trim(groups), '|', ' '))
    text = '`&'//names(1)%text//'`'
    do i = 2, size(names)
      if (i < size(names)) then
        text = text//', '
      else if (index(groups, '|') > 0) then
        text = text//' or '
      else
        text = text//' '//between//' '
      end if
      text = text//'`&'//names(i)%text//'`'
    end do
  end function listed

  pure function swept_text(rows) result(text)
    !! Say which names of a group a sweep may vary; there is at least one.
    integer, intent(in) :: rows(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(rows)
      if (is_sweepable(name_table(rows(i)))) text = text//', `'//trim(name_table(rows(i))%name)//'`'
    end do
    text = '`&sweep` may vary '//text(3:)//'.'
  end function swept_text

  pure subroutine put_table(builder, rows)
    !! Put a pipe table with aligned columns.
    type(text_builder), intent(inout) :: builder
    integer, intent(in) :: rows(:)
    character(widest) :: cells(columns, 0:size(rows))
    integer :: width(columns), i
    cells(:, 0) = heads
    do i = 1, size(rows)
      cells(:, i) = cells_of(name_table(rows(i)))
    end do
    width = maxval(len_trim(cells), dim=2)
    call builder%append_line('')
    call put_row(builder, cells(:, 0), width)
    call put_row(builder, [(repeat('-', widest), i=1, columns)], width)
    do i = 1, size(rows)
      call put_row(builder, cells(:, i), width)
    end do
  end subroutine put_table

  pure function cells_of(row) result(cells)
    !! Return the cells of a name's row.
    type(input_name), intent(in) :: row
    character(widest) :: cells(columns)
    cells(1) = '`'//trim(row%name)//'`'
    cells(2) = kind_text(row)
    cells(3) = row%unit
    if (.not. has_unit(row)) cells(3) = '-'
    cells(4) = range_text(row)
    cells(5) = row%default
    if (row%default == '') cells(5) = '-'
    if (row%required) cells(5) = 'required'
    cells(6) = row%meaning
  end function cells_of

  pure subroutine put_row(builder, cells, width)
    !! Put one line of a pipe table, with padded cells.
    type(text_builder), intent(inout) :: builder
    character(*), intent(in) :: cells(:)
    integer, intent(in) :: width(:)
    integer :: i
    do i = 1, size(cells)
      call builder%append('| '//cells(i) (:width(i))//' ')
    end do
    call builder%append_line('|')
  end subroutine put_row

  pure subroutine put_wrapped(builder, paragraph)
    !! Wrap a paragraph at blanks to `text_width`; `|` begins a list item.
    type(text_builder), intent(inout) :: builder
    character(*), intent(in) :: paragraph
    type(string), allocatable :: parts(:)
    integer :: i
    parts = lines_of(paragraph, '|')
    call builder%append_line(wrapped(parts(1)%text, text_width, 0))
    if (size(parts) > 1) call builder%append_line('')
    do i = 2, size(parts)
      call builder%append_line(wrapped('- '//parts(i)%text, text_width, 2))
    end do
  end subroutine put_wrapped

end module bw_scene_describe
