module bw_scene_summary
  !! The summary of a scene, its method and cost: the head of a report, and `beamwave check`.
  use bw_input_values, only: position_of
  use bw_kinds, only: dp, i8
  use bw_beam_par, only: beam_text, has_fibre
  use bw_beam_units, only: beam_units, units_of
  use bw_blows, only: enough
  use bw_case_cost, only: case_bytes
  use bw_hint, only: hint_line
  use bw_modes_par, only: by_tolerance
  use bw_noise_alone, only: most_numbers
  use bw_record_case, only: few_numbers
  use bw_result_draft, only: result_draft
  use bw_result_layout, only: result_layout
  use bw_result_table, only: most_waiting
  use bw_scene, only: answers_by_modes, by_pieces, count_methods, effect_names, scene_type
  use bw_scene_groups, only: effects_text
  use bw_scene_cases, only: case_count
  use bw_text, only: append, shortest, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: scene_heading, scene_summary, unknowns_text, bytes_text, case_numbers, cost_summary, disk_bytes
  public :: working_bytes

contains

  pure function scene_heading(scene) result(text)
    !! Return the scene's name, and its title if it has one.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    text = scene%name
    if (scene%header%title /= '') text = text//': '//trim(scene%header%title)
    text = text//new_line('a')
  end function scene_heading

  function scene_summary(scene, layout, hint) result(text)
    !! Describe the simulation line by line, indented by two.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    logical, intent(in), optional :: hint          !! add the line on omitted effects, which needs a few modes; absent: yes
    character(:), allocatable :: text
    type(text_builder) :: lines
    type(beam_units) :: units
    logical :: hints
    call lines%append_line('  scene      '//scene%file)
    if (position_of(scene%groups, 'beam') > 0) then
      units = units_of(scene%beam)
      call lines%append('  beam       length '//shortest(units%length, 6)//' m'//beam_text(scene%beam)//', mass '// &
                        shortest(units%mass, 6)//' kg, h = sqrt(EI/(rho A)) = '//shortest(units%h%hi, 6)//' m2/s')
      if (any(scene%groups(position_of(scene%groups, 'beam'))%values%follows_sweep())) call lines%append(' in case 1')
      call lines%append_line('')
    end if
    if (.not. allocated(scene%record) .or. effect_names(scene) /= '') then
      call lines%append_line('  effects    '//effects_text(scene))
    end if
    if (.not. allocated(scene%record)) then
      call lines%append_line('  method     '//method_text(scene)//', '//modes_text(scene, layout))
    end if
    if (allocated(scene%response)) call lines%append_line('  response   '//response_text(scene))
    if (allocated(scene%frequency_response)) call lines%append_line('  harmonic   '//harmonic_text(scene))
    call lines%append(unknowns_text(scene))
    if (size(scene%sweeps) > 0) call lines%append_line('  '//merge('design', 'sweep ', allocated(scene%design))//'     '// &
                                                       sweep_text(scene))
    hints = .not. allocated(scene%record)
    if (present(hint)) hints = hints .and. hint
    if (hints) call lines%append(hint_line(scene))
    text = lines%text()
  end function scene_summary

  function unknowns_text(scene) result(text)
    !! List the numbers to be identified, with their ranges.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    integer :: i
    text = ''
    if (.not. allocated(scene%unknowns)) return
    do i = 1, size(scene%unknowns)
      associate (unknown => scene%unknowns(i))
        text = text//'  unknown    '//unknown%parameter//', '//shortest(unknown%first, 6)//' to '//shortest(unknown%last, 6)
        if (unknown%unit /= '1') text = text//' '//unknown%unit
        text = text//new_line('a')
      end associate
    end do
  end function unknowns_text

  pure function method_text(scene) result(text)
    !! Name the method of finding modes; in a sweep with the number of cases, if methods differ.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    character(:), allocatable :: otherwise
    integer(i8) :: closed, cases
    otherwise = 'Galerkin, polynomials in the strains'
    if (by_pieces(scene)) otherwise = 'exact modes of uniform pieces'
    call count_methods(scene, closed, cases)
    text = 'closed form'
    if (closed == 0) text = otherwise
    if (closed > 0 .and. closed < cases) text = text_of(closed)//' of '//text_of(cases)//' cases in closed form, the others '// &
      otherwise
  end function method_text

  function modes_text(scene, layout) result(text)
    !! Report the number of modes, or the tolerance that determines it.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    character(:), allocatable :: text
    if (by_tolerance(scene%modes)) then
      text = 'as many modes as the tolerance requires ('// &
        scene%groups(position_of(scene%groups, 'modes'))%number_or_swept('tolerance', '')//')'
    else if (allocated(scene%capture)) then
      text = text_of(layout%modes_before)//' modes before the capture, '//text_of(layout%modes)//' after it'
    else
      text = text_of(layout%modes)//' modes'
    end if
  end function modes_text

  function response_text(scene) result(text)
    !! Describe the histories, and the spectrum if there is one.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    type(string), allocatable :: asked(:)
    integer :: q
    associate (response => scene%response)
      text = text_of(response%samples)//' samples over '//shortest(response%duration, 6)//' s at '// &
        places_text(response%points)//', displacement'
      allocate (asked(0))
      if (response%velocity) call append(asked, 'velocity')
      if (response%acceleration) call append(asked, 'acceleration')
      if (response%bending_moment) call append(asked, 'bending moment')
      if (response%bending_moment .and. .not. (has_fibre(scene%beam) .or. scene%beam%is_lumped)) &
        asked(size(asked))%text = 'bending moment (no stress without &beam extreme_fibre)'
      if (response%shear_force) call append(asked, 'shear force')
    end associate
    do q = 1, size(asked)
      if (q < size(asked)) text = text//', '//asked(q)%text
      if (q == size(asked)) text = text//' and '//asked(q)%text
    end do
    if (allocated(scene%spectrum)) text = text//'; spectrum ('//scene%spectrum%window//' window)'
  end function response_text

  function harmonic_text(scene) result(text)
    !! Describe the response to a harmonic force, and its method.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    associate (asked => scene%frequency_response)
      text = text_of(size(asked%frequency))//' frequencies from '//shortest(asked%frequency(1), 6)//' to '// &
        shortest(asked%frequency(size(asked%frequency)), 6)//' Hz, force at xi = '// &
        scene%groups(position_of(scene%groups, 'frequency_response'))%number_or_swept('position', '', digits=15)//', '// &
        asked%quantity//' at '//places_text(asked%points)
    end associate
    if (answers_by_modes(scene)) then
      text = text//', by modes'
    else
      text = text//', exact'
    end if
  end function harmonic_text

  pure function places_text(points) result(text)
    !! List the points of histories, or give the number of many.
    real(dp), intent(in) :: points(:)              !! ξ
    character(:), allocatable :: text
    integer, parameter :: most = 4
    integer :: p
    if (size(points) > most) then
      text = text_of(size(points))//' points'
      return
    end if
    text = 'xi = '//shortest(points(1), 15)
    do p = 2, size(points)
      text = text//', '//shortest(points(p), 15)
    end do
  end function places_text

  function sweep_text(scene) result(text)
    !! Report the number of cases, and the sweeps or the table that define them.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    integer, parameter :: most = 8                !! sweeps that are listed
    character(2) :: mark
    integer :: s
    text = text_of(case_count(scene))//trim(merge(' case: ', ' cases:', case_count(scene) == 1))
    if (allocated(scene%design)) text = text//' the rows of '//scene%design%file//' with'
    mark = ''
    do s = 1, min(most, size(scene%sweeps))
      associate (sweep => scene%sweeps(s))
        if (s > 1) mark = merge(', ', ' x', sweep%designed)
        text = text//trim(mark)//' '
        if (.not. sweep%designed) text = text//text_of(size(sweep%values))//' of '
        text = text//sweep%parameter
        if (sweep%designed) text = text//' ('//shortest(minval(sweep%values), 6)//' to '//shortest(maxval(sweep%values), 6)//')'
        if (.not. sweep%designed) text = text//span_text(sweep%values)
      end associate
    end do
    if (size(scene%sweeps) > most) text = text//', and '//text_of(size(scene%sweeps) - most)//' more'
    if (count(.not. scene%sweeps%designed) > 1) text = text//'; the first varies slowest'
  end function sweep_text

  pure function span_text(values) result(text)
    !! List the swept values, or the first and the last of many, in brackets.
    real(dp), intent(in) :: values(:)
    integer, parameter :: most = 4                !! that are listed
    character(:), allocatable :: text
    integer :: i
    text = shortest(values(1), 6)
    if (size(values) > most) then
      text = text//' to '//shortest(values(size(values)), 6)
    else
      do i = 2, size(values)
        text = text//', '//shortest(values(i), 6)
      end do
    end if
    text = ' ('//text//')'
  end function span_text

  function cost_summary(scene, layout, bytes) result(text)
    !! Report the memory and disk space of a run, for `beamwave check`.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: bytes          !! of memory
    character(:), allocatable :: text
    text = '  memory     '//bytes_text(bytes)//new_line('a')// &
      '  result     '//bytes_text(disk_bytes(scene, layout))//new_line('a')
  end function cost_summary

  function disk_bytes(scene, layout) result(bytes)
    !! Return the bytes that a run writes.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8) :: bytes
    type(result_draft) :: draft
    call draft%plan(scene, layout)
    bytes = draft%head%bytes
  end function disk_bytes

  integer(i8) function case_numbers(scene, layout) result(count)
    !! Return the number of values of a case.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_draft) :: draft
    call draft%plan(scene, layout)
    count = draft%case_numbers
  end function case_numbers

  integer(i8) function working_bytes(scene, layout) result(bytes)
    !! Estimate the memory of the first case without running it: its numbers, twice while they are written, times,
    !! shapes, modes, the search of histories for waves, and about 27 MB of program and libraries; for a sweep also
    !! buffered cases and the statuses of all.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer, parameter :: most_shapes = 2**22        ! in memory at a time
    integer, parameter :: wave_numbers = 30          ! by frequency
    integer, parameter :: time_copies = 3
    integer, parameter :: line_bytes = 20000000      ! of a group of lines that are fitted together
    integer, parameter :: of_case = 16               ! its number and status
    integer(i8), parameter :: column_numbers = 2**22 ! of all cases, for which quantiles are found together
    integer(i8) :: shapes, numbers
    shapes = int(max(layout%modes, layout%modes_before), i8)*max(layout%points, 2*layout%profile)
    shapes = min(shapes, int(most_shapes, i8))
    numbers = case_numbers(scene, layout)
    bytes = 8*(2*numbers + shapes + wave_numbers*int(layout%frequencies, i8) + time_copies*int(layout%samples, i8)) + 27000000
    if (layout%quantiles > 0) bytes = bytes + 8*min(column_numbers, int(layout%cases, i8)*max(layout%modes, layout%points, 1))
    if (.not. allocated(scene%record)) bytes = bytes + case_bytes(scene)
    if (allocated(layout%record)) bytes = bytes + record_bytes(layout%record%longest, layout%points)
    if (allocated(scene%spectrum)) bytes = bytes + line_bytes
    bytes = bytes + 8*min(int(most_waiting, i8), numbers*layout%cases) + of_case*int(layout%cases, i8)
  end function working_bytes

  pure integer(i8) function record_bytes(samples, sensors) result(bytes)
    !! Estimate the memory of a record while its lines are found: the record, its residuals, and a copy if the next case
    !! needs it; searches for shared noise and blows; transforms of one sensor, bands of all; measured.
    integer, intent(in) :: samples, sensors
    integer, parameter :: of_sample = 240, of_sensor = 700000, of_libraries = 10000000
    integer(i8) :: numbers
    numbers = int(samples, i8)*sensors
    bytes = of_libraries + 16*numbers + int(of_sample, i8)*samples + int(of_sensor, i8)*sensors
    if (numbers <= few_numbers) bytes = bytes + 8*numbers
    bytes = bytes + max(16*min(numbers, int(most_numbers, i8)), 32*min(numbers, int(enough, i8)))
  end function record_bytes

  pure function bytes_text(bytes) result(text)
    !! Format bytes in kB, MB or GB (powers of 1000) with three digits.
    integer(i8), intent(in) :: bytes
    character(:), allocatable :: text
    if (bytes < 1000000) then
      text = shortest(real(bytes, dp)/1.0e3_dp, 3)//' kB'
    else if (bytes < 1000000000) then
      text = shortest(real(bytes, dp)/1.0e6_dp, 3)//' MB'
    else
      text = shortest(real(bytes, dp)/1.0e9_dp, 3)//' GB'
    end if
  end function bytes_text

end module bw_scene_summary
