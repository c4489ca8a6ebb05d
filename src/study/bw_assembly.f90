module bw_assembly
  !! The result of a sweep, put together from the journals of all processes that had a part in it.
  use bw_case_fields, only: case_field, case_length, fields_of
  use bw_case_journal, only: journal_reader
  use bw_case_result, only: case_done
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i1, i8
  use bw_notes, only: notes_type
  use bw_posix, only: remove_file
  use bw_result_file, only: create_result, result_file
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_sweep_table, only: sweep_table
  use bw_text, only: string, text_of
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private
  public :: assemble

  integer(i8), parameter :: block_numbers = 1000000      !! 8 MB of cases are written at a time

  type, public :: assembly_type
    !! A sweep's result, and what there is to say of it.
    type(result_file) :: file
    type(sweep_table) :: table
    type(notes_type) :: notes
    integer(i8) :: not_trusted = 0                       !! cases
    integer(i1), allocatable, private :: done(:)         !! (cases)
    real(dp), allocatable, private :: block(:, :)        !! numbers of neighbouring cases
    integer(i8), private :: first = 1                    !! the first of them
    integer, private :: held = 0                         !! how many there are
  end type assembly_type

contains

  subroutine assemble(scene, layout, unfinished, assembly, error)
    !! Every case is taken from the first journal that has it: all have the same bits.
    !! **Errors**: the result cannot be written, or a journal is damaged, which is then taken away.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    type(assembly_type), intent(out) :: assembly
    type(error_type), allocatable, intent(out) :: error
    type(string), allocatable :: paths(:)
    integer(i8) :: length
    integer :: i
    call create_result(unfinished%result_path(), scene, layout, assembly%file, error)
    if (allocated(error)) return
    allocate (assembly%done(layout%cases), source=0_i1)
    length = case_length(fields_of(layout))
    allocate (assembly%block(length, max(1_i8, min(int(layout%cases, i8), block_numbers/length))))
    assembly%table = sweep_table(scene, layout)
    paths = unfinished%journals()
    do i = 1, size(paths)
      if (.not. allocated(error)) call take_journal(paths(i)%text, unfinished%work, assembly, error)
    end do
    if (.not. allocated(error) .and. any(assembly%done == 0)) call fail(error, status_bad_file, &
      unfinished%directory//': '//text_of(count(assembly%done == 0))//' finished cases are gone; the same command does them again')
    if (allocated(error)) call assembly%file%close()
  end subroutine assemble

  subroutine take_journal(path, work, assembly, error)
    character(*), intent(in) :: path, work
    type(assembly_type), intent(inout) :: assembly
    type(error_type), allocatable, intent(inout) :: error
    type(journal_reader) :: reader
    type(string), allocatable :: notes(:)
    integer(i8) :: index
    logical :: sound
    if (.not. reader%open(path, work)) return
    sound = .true.
    do while (reader%next(index))
      if (assembly%done(index) /= 0) cycle
      call make_room(index, assembly, error)
      if (allocated(error)) exit
      sound = reader%take(assembly%block(:, assembly%held), notes)
      if (.not. sound) exit
      call take_account(index, notes, assembly)
    end do
    call reader%close()
    if (sound .and. .not. allocated(error)) call write_block(assembly, error)
    if (sound) return
    call remove_file(path)
    call fail(error, status_bad_file, path//': is damaged and was removed; the same command does its cases again')
  end subroutine take_journal

  subroutine make_room(index, assembly, error)
    !! The next place in the block; a block that is full, or does not reach up to this case, is written first.
    integer(i8), intent(in) :: index
    type(assembly_type), intent(inout) :: assembly
    type(error_type), allocatable, intent(inout) :: error
    if (assembly%held == size(assembly%block, 2) .or. index /= assembly%first + assembly%held) then
      call write_block(assembly, error)
      assembly%first = index
    end if
    assembly%held = assembly%held + 1
  end subroutine make_room

  subroutine write_block(assembly, error)
    type(assembly_type), intent(inout) :: assembly
    type(error_type), allocatable, intent(inout) :: error
    if (assembly%held > 0) call assembly%file%put_cases(assembly%first, assembly%block(:, :assembly%held), error)
    assembly%held = 0
  end subroutine write_block

  subroutine take_account(index, notes, assembly)
    !! What the report and the notes say of a case.
    integer(i8), intent(in) :: index
    type(string), intent(in) :: notes(:)
    type(assembly_type), intent(inout) :: assembly
    associate (numbers => assembly%block(:, assembly%held))
      assembly%done(index) = 1_i1
      if (nint(numbers(size(numbers))) /= case_done) assembly%not_trusted = assembly%not_trusted + 1
      call assembly%notes%add(index, notes)
      call assembly%table%add(index, numbers)
    end associate
  end subroutine take_account

end module bw_assembly
